//! Prints `modelDescription.xml`; the committed file is its output.
fn main() {
    print!("{}", poropunch::model_description::xml());
}
