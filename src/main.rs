//! The `hemicube` command.
fn main() {}
