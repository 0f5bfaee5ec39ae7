//! The command line of Subsolid.
fn main() {}
