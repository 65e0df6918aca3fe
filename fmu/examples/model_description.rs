//! Prints `modelDescription.xml`; the committed file is its output. With `3` that of FMI 3.0, with `terminals` its
//! terminals.
use poropunch::model_description::{fmi3, xml};

fn main() {
    let text = match std::env::args().nth(1).as_deref() {
        Some("3") => fmi3::xml(),
        Some("terminals") => fmi3::terminals(),
        _ => xml(),
    };
    print!("{text}");
}
