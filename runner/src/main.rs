//! poropunch's command line.
fn main() {}
