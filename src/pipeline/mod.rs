//! The commands; the only room that sees every stage.
