//! Work that may panic, whose panic is a result.

use std::panic::{AssertUnwindSafe, catch_unwind};

/// Runs work of which also a panic is a result: a driver that misbehaves on a machine that is seen once must not take
/// the other parts with it.
pub fn guarded<T>(work: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
        Err(format!("panicked: {}", text.unwrap_or("no message")))
    })
}

#[cfg(test)]
mod tests {
    use super::guarded;

    #[test]
    fn a_panic_is_a_fault_with_its_words() {
        assert_eq!(guarded(|| Ok(1)), Ok(1));
        let fault: Result<(), String> = guarded(|| panic!("no {}", 7));
        assert_eq!(fault, Err("panicked: no 7".to_owned()));
    }
}
