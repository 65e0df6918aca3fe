//! Prints the table of the fields, `fmu/src/fields/README.md`.

fn main() {
    print!("{}", poropunch::fields::markdown());
}
