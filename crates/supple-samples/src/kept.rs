//! Samples are made once in a process, and kept.

use std::sync::{Mutex, PoisonError};
use supple::Result;

/// What `made` holds, after `make` has made it where it holds nothing. Two that come at once both make it: a lock held
/// meanwhile would wait for ever where `make`'s threads take up work that asks for the same sample.
pub(crate) fn kept<T: Clone>(
    made: &Mutex<Option<T>>,
    make: impl FnOnce() -> Result<T>,
) -> Result<T> {
    let lock = || made.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(sample) = &*lock() {
        return Ok(sample.clone());
    }
    let sample = make()?;
    *lock() = Some(sample.clone());
    Ok(sample)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_made_is_made_once_and_a_failure_is_tried_again() {
        let made = Mutex::new(None);
        let failed = kept(&made, || Err(supple::Error::invalid("sample", "fails")));
        assert!(failed.is_err());
        assert_eq!(kept(&made, || Ok(5)).unwrap(), 5);
        assert_eq!(kept(&made, || Ok(6)).unwrap(), 5);
    }
}
