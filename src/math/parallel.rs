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

/// Mutable data of a row of items that can be cut between two items, so that tasks own disjoint parts.
pub trait Split: Send + Sized {
    /// What one item is handed out as.
    type Item;

    /// The first `items` items, and the rest.
    fn split(self, items: usize) -> (Self, Self);

    /// Takes the first item off; there must be one.
    fn pop(&mut self) -> Self::Item;
}

impl<'a, T: Send> Split for &'a mut [T] {
    type Item = &'a mut T;

    fn split(self, items: usize) -> (Self, Self) {
        self.split_at_mut(items)
    }

    fn pop(&mut self) -> &'a mut T {
        let (first, rest) = std::mem::take(self).split_at_mut(1);
        *self = rest;
        &mut first[0]
    }
}

/// One slice an item, of the lengths that `offsets` gives: see [`super::Rows::offsets`].
pub struct RowsMut<'a, T> {
    offsets: &'a [u32],
    entries: &'a mut [T],
}

impl<'a, T> RowsMut<'a, T> {
    /// `offsets` has one entry more than there are rows and rises by `entries.len()` in all.
    pub fn new(offsets: &'a [u32], entries: &'a mut [T]) -> Self {
        Self { offsets, entries }
    }
}

impl<'a, T: Send> Split for RowsMut<'a, T> {
    type Item = &'a mut [T];

    fn split(self, items: usize) -> (Self, Self) {
        let cut = (self.offsets[items] - self.offsets[0]) as usize;
        let (head, tail) = self.entries.split_at_mut(cut);
        (
            Self::new(&self.offsets[..=items], head),
            Self::new(&self.offsets[items..], tail),
        )
    }

    fn pop(&mut self) -> &'a mut [T] {
        let length = (self.offsets[1] - self.offsets[0]) as usize;
        let (first, rest) = std::mem::take(&mut self.entries).split_at_mut(length);
        (self.entries, self.offsets) = (rest, &self.offsets[1..]);
        first
    }
}

/// One slice an item, all `stride` long but the last, which may be shorter.
pub struct Strided<'a, T> {
    stride: usize,
    entries: &'a mut [T],
}

impl<'a, T> Strided<'a, T> {
    /// `entries` holds `stride` for each item; the last may have fewer.
    pub fn new(stride: usize, entries: &'a mut [T]) -> Self {
        Self { stride, entries }
    }
}

impl<'a, T: Send> Split for Strided<'a, T> {
    type Item = &'a mut [T];

    fn split(self, items: usize) -> (Self, Self) {
        let cut = (items * self.stride).min(self.entries.len());
        let (head, tail) = self.entries.split_at_mut(cut);
        (Self::new(self.stride, head), Self::new(self.stride, tail))
    }

    fn pop(&mut self) -> &'a mut [T] {
        let length = self.stride.min(self.entries.len());
        let (first, rest) = std::mem::take(&mut self.entries).split_at_mut(length);
        self.entries = rest;
        first
    }
}

macro_rules! split_tuple {
    ($($part:ident),+) => {
        impl<$($part: Split),+> Split for ($($part,)+) {
            type Item = ($($part::Item,)+);

            #[allow(non_snake_case)] // the parts are called like their types
            fn split(self, items: usize) -> (Self, Self) {
                let ($($part,)+) = self;
                $(let $part = $part.split(items);)+
                (($($part.0,)+), ($($part.1,)+))
            }

            #[allow(non_snake_case)]
            fn pop(&mut self) -> Self::Item {
                let ($($part,)+) = self;
                ($($part.pop(),)+)
            }
        }
    };
}
split_tuple!(A, B);
split_tuple!(A, B, C);
split_tuple!(A, B, C, D);

/// Calls `f(i, item i of parts)` for `i` in `0..count`; a task gets `grain` items at most.
pub fn par_split<S: Split>(
    count: usize,
    grain: usize,
    parts: S,
    f: impl Fn(usize, S::Item) + Sync,
) {
    split_range(0..count, grain.max(1), parts, &f);
}

fn split_range<S: Split>(
    range: std::ops::Range<usize>,
    grain: usize,
    mut parts: S,
    f: &(impl Fn(usize, S::Item) + Sync),
) {
    if range.len() <= grain || cfg!(not(feature = "threads")) {
        range.for_each(|i| f(i, parts.pop()));
        return;
    }
    let half = range.len() / 2;
    let middle = range.start + half;
    let (head, tail) = parts.split(half);
    par_join(
        || split_range(range.start..middle, grain, head, f),
        || split_range(middle..range.end, grain, tail, f),
    );
}

/// Runs both, at the same time where there are threads.
pub fn par_join(a: impl FnOnce() + Send, b: impl FnOnce() + Send) {
    #[cfg(feature = "threads")]
    rayon::join(a, b);
    #[cfg(not(feature = "threads"))]
    {
        a();
        b();
    }
}

/// Runs `f` on a thread of the pool, so that the parallel loops inside it do not each have to wake it.
pub fn in_pool<R: Send>(f: impl FnOnce() -> R + Send) -> R {
    #[cfg(feature = "threads")]
    {
        rayon::scope(|_| f())
    }
    #[cfg(not(feature = "threads"))]
    {
        f()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_item_is_visited_once_with_its_own_parts() {
        let offsets: Vec<u32> = (0..=100u32).map(|i| i * i).collect();
        for grain in [1, 7, 1000] {
            let mut single = vec![0usize; 100];
            let mut rows = vec![0usize; 10_000];
            let mut strided = vec![0usize; 299];
            let parts = (
                &mut single[..],
                RowsMut::new(&offsets, &mut rows),
                Strided::new(3, &mut strided),
            );
            par_split(100, grain, parts, |i, (one, row, three)| {
                *one += i;
                assert_eq!(row.len(), 2 * i + 1);
                row.iter_mut().chain(three).for_each(|x| *x += i);
            });
            assert!(single.iter().enumerate().all(|(i, &x)| x == i));
            assert!(rows.iter().enumerate().all(|(k, &x)| x == k.isqrt()));
            assert!(strided.iter().enumerate().all(|(k, &x)| x == k / 3));
        }
    }
}
