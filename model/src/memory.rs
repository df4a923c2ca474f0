//! Memory hints to operating system and processor: large pages, prefetch of cache lines, and the
//! return of freed blocks.
//!
//! All of it is hints that change no value, and the only unsafe code of the engines but for the
//! choice of instructions in the event-driven one.
#![allow(
    unsafe_code,
    reason = "hints to the hardware, the kernel and the allocator have no safe interface"
)]

/// Prefetches an element of a slice that will be needed soon into the second-level cache; harmless
/// where there is none, so that no caller has to check.
///
/// The second-level cache is used, because the first one of some processors drops requests when
/// twenty are under way.
#[inline(always)]
pub fn prefetch<T>(slice: &[T], index: usize) {
    prefetch_into::<T, 2>(slice, index);
}

/// Prefetches an element of a slice that is needed next into the first-level cache; [`prefetch`]
/// uses the second.
#[inline(always)]
pub fn prefetch_next<T>(slice: &[T], index: usize) {
    prefetch_into::<T, 3>(slice, index);
}

/// Prefetches an element of a slice into the cache of the given level: `CACHE` is 3 for the first
/// and 2 for the second, as processors number them.
#[inline(always)]
fn prefetch_into<T, const CACHE: i32>(slice: &[T], index: usize) {
    #[cfg(target_arch = "x86_64")]
    {
        let element = slice.as_ptr().wrapping_add(index);
        // SAFETY: a prefetch reads nothing that the program sees, and does nothing where there is
        // no memory.
        unsafe { std::arch::x86_64::_mm_prefetch::<CACHE>(element.cast()) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (slice, index);
}

/// Returns an empty vector with memory for `capacity` elements, on large pages where the system
/// grants them.
///
/// Disks collide in no helpful order, and each access to another small page costs a walk of the
/// page table.
pub fn reserved<T>(capacity: usize) -> Vec<T> {
    let vector = Vec::with_capacity(capacity);
    #[cfg(target_os = "linux")]
    {
        const PAGE: usize = 4096;
        const LARGE: usize = 2 << 20;
        let begin = vector.as_ptr() as usize;
        let end = begin + capacity * size_of::<T>();
        let (first, last) = (begin.next_multiple_of(PAGE), end / PAGE * PAGE);
        if last >= first + LARGE {
            // SAFETY: whole pages inside one live allocation; the advice changes how they are
            // backed, not what they hold. A refusal by the system changes nothing.
            unsafe {
                libc::madvise(
                    first as *mut libc::c_void,
                    last - first,
                    libc::MADV_HUGEPAGE,
                )
            };
        }
    }
    vector
}

/// Returns a vector of `count` copies of a value, with memory on large pages as by [`reserved`].
pub fn filled<T: Clone>(value: T, count: usize) -> Vec<T> {
    let mut vector = reserved(count);
    vector.resize(count, value);
    vector
}

/// Returns the memory that this process can still allocate \[bytes\]: the lesser of the free memory
/// of the machine and the rest of the process's limit of address space (`ulimit -v`). `None` if the
/// system does not tell.
pub fn available() -> Option<f64> {
    let free = value_of("/proc/meminfo", "MemAvailable:")?;
    let limit = std::fs::read_to_string("/proc/self/limits").ok();
    let limit = limit.as_deref().and_then(|text| {
        let line = text
            .lines()
            .find_map(|one| one.strip_prefix("Max address space"))?;
        line.split_whitespace().next()?.parse::<f64>().ok()
    });
    let left = limit.zip(value_of("/proc/self/status", "VmSize:"));
    Some(left.map_or(free, |(limit, taken)| free.min((limit - taken).max(0.0))))
}

/// Returns the number in the line of a system file that starts with `name`, converted from
/// kibibytes \[bytes\].
fn value_of(file: &str, name: &str) -> Option<f64> {
    let text = std::fs::read_to_string(file).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    let kibibytes: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024.0 * kibibytes)
}

/// Makes the allocator give large blocks back to the system as soon as they are freed; called at
/// the start of a program.
///
/// The GNU allocator keeps blocks of up to 32 MiB once it has seen one freed, for each thread by
/// itself. A checkpoint is made of such blocks, so that with several threads the peak of the
/// process was twice what is used at any time. A program calls this first.
pub fn return_large_blocks() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        /// Size of a block from which freed memory goes back to the system at once \[bytes\].
        const LARGE: libc::c_int = 1 << 20;
        // SAFETY: the two thresholds are those of the allocator, and change only where blocks come
        // from. Where it is refused, blocks are kept.
        unsafe {
            libc::mallopt(libc::M_MMAP_THRESHOLD, LARGE);
            libc::mallopt(libc::M_TRIM_THRESHOLD, LARGE);
        }
    }
}
