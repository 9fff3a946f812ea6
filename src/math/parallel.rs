//! Loops that use threads where the `threads` feature is on, with results that do not depend on it.

/// `out[i] = f(i)` for `i` in `0..count`.
pub fn par_map<T: Send>(count: usize, f: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    #[cfg(feature = "threads")]
    {
        use rayon::prelude::*;
        (0..count).into_par_iter().map(f).collect()
    }
    #[cfg(not(feature = "threads"))]
    {
        (0..count).map(f).collect()
    }
}

/// Calls `f(i, &mut items[i])` for every item; `grain` items at least make a task.
pub fn par_each<T: Send>(items: &mut [T], grain: usize, f: impl Fn(usize, &mut T) + Sync + Send) {
    #[cfg(feature = "threads")]
    {
        use rayon::prelude::*;
        items
            .par_iter_mut()
            .with_min_len(grain)
            .enumerate()
            .for_each(|(i, item)| f(i, item));
    }
    #[cfg(not(feature = "threads"))]
    {
        let _ = grain;
        items
            .iter_mut()
            .enumerate()
            .for_each(|(i, item)| f(i, item));
    }
}
