//! Whether the user asks the program to end: signals belong to the whole process, and so does this.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock};

static ASKED: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);

/// What a handler of signals sets. A run ends after the step it is at then, with its results complete.
#[must_use]
pub fn flag() -> Arc<AtomicBool> {
    Arc::clone(&ASKED)
}

/// Whether the user has asked.
pub(super) fn is_asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}
