//! Loops that use threads where the `threads` feature is on, with results that do not depend on it.
//!
//! All of them come down to one recursive halving over [`par_join`], which hands the thread pool two plain
//! function objects: the pool's own generic code is then compiled once and not for every loop.

/// `out[i] = f(i)` for `i` in `0..count`.
pub fn par_map<T: Send>(count: usize, f: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    let mut out: Vec<Option<T>> = (0..count).map(|_| None).collect();
    par_each(&mut out, 1, |i, slot| *slot = Some(f(i)));
    out.into_iter().flatten().collect()
}

/// Calls `f(i, &mut items[i])` for every item; about `grain` items at least make a task.
pub fn par_each<T: Send>(items: &mut [T], grain: usize, f: impl Fn(usize, &mut T) + Sync + Send) {
    let count = items.len();
    par_split(
        count,
        grain.max(count / (TASKS_A_THREAD * threads())),
        items,
        f,
    );
}

/// Tasks that a loop of many items is cut into, for each thread: enough to even out what they cost.
const TASKS_A_THREAD: usize = 8;

/// How many threads loops use.
pub fn threads() -> usize {
    #[cfg(feature = "threads")]
    {
        rayon::current_num_threads()
    }
    #[cfg(not(feature = "threads"))]
    {
        1
    }
}

/// Which of [`threads`] this one is; 0 outside of the pool.
pub fn thread_index() -> usize {
    #[cfg(feature = "threads")]
    {
        rayon::current_thread_index().unwrap_or(0)
    }
    #[cfg(not(feature = "threads"))]
    {
        0
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

/// [`par_split`] in the pool with a task for each item; of one item alone on this thread.
pub fn par_members<S: Split>(count: usize, parts: S, f: impl Fn(usize, S::Item) + Sync) {
    if count > 1 {
        in_pool(|| par_split(count, 1, parts, &f));
    } else {
        par_split(count, 1, parts, f);
    }
}

/// Runs both, at the same time where there are threads.
pub fn par_join(a: impl FnOnce() + Send, b: impl FnOnce() + Send) {
    let (mut a, mut b) = (Some(a), Some(b));
    let mut a = || a.take().map_or((), |a| a());
    let mut b = || b.take().map_or((), |b| b());
    join(&mut a, &mut b);
}

/// What the pool is given, once.
type Task<'a> = &'a mut (dyn FnMut() + Send);

fn join(a: Task<'_>, b: Task<'_>) {
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
    let (mut f, mut result) = (Some(f), None);
    enter(&mut || result = f.take().map(|f| f()));
    result.expect("it has run")
}

fn enter(task: Task<'_>) {
    #[cfg(feature = "threads")]
    rayon::scope(|_| task());
    #[cfg(not(feature = "threads"))]
    task();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_keep_their_order_and_joins_run_both_once() {
        for count in [0, 1, 7, 10_000] {
            let squares = in_pool(|| par_map(count, |i| i * i));
            assert!(squares.iter().enumerate().all(|(i, &x)| x == i * i));
            let mut items = vec![1; count];
            par_each(&mut items, 5, |i, item| *item += i);
            assert!(items.iter().enumerate().all(|(i, &x)| x == i + 1));
            assert_eq!((squares.len(), items.len()), (count, count));
        }
        let (mut a, mut b) = (0, 0);
        par_join(|| a += 1, || b += 1);
        assert_eq!((a, b), (1, 1));
    }

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
