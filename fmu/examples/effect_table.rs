//! Prints the documentation of the effects, `fmu/src/effect/README.md`.
fn main() {
    print!("{}", poropunch::interface::effect_table::markdown());
}
