//! Forward kinematics is called millions of times in simulations on many threads, where the allocator is what
//! they share; one solve may therefore allocate next to nothing.

// An allocator is an unsafe trait by definition; this one only counts and hands on to the system's.
#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::hint::black_box;

use paracal::conditions::Conditions;
use paracal::files::Machine;
use paracal::pose::Pose;

/// Counts what the calling thread allocates: the test harness has threads of its own.
struct Counting;

thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

fn count_one() {
    // The system allocates for a thread that is ending as well, when its counter is gone.
    let _ = COUNT.try_with(|count| count.set(count.get() + 1));
}

// SAFETY: every call goes to the system's allocator with the arguments as they are.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count_one();
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count_one();
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count_one();
        unsafe { System.realloc(block, layout, size) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        unsafe { System.dealloc(block, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn allocations<T>(f: impl FnOnce() -> T) -> (usize, T) {
    let before = COUNT.get();
    let value = f();
    (COUNT.get() - before, value)
}

#[test]
fn the_counter_counts() {
    let (count, vector) = allocations(|| black_box(vec![1.0_f64; 100]));
    assert_eq!((count, vector.len()), (1, 100));
}

#[test]
fn one_forward_solve_allocates_at_most_twice() {
    let machine = Machine::read(concat!(env!("CARGO_MANIFEST_DIR"), "/mechanisms/table5.toml")).unwrap();
    let mechanism = machine.mechanism.as_ref();
    let (c, at, home) = (mechanism.values(), Conditions::unknown(), mechanism.home());
    let mut worst = 0;
    for corner in machine.workspace.unwrap().corners() {
        let joints = mechanism.inverse(c, &corner, &at).unwrap();
        let (count, pose): (usize, Pose) = allocations(|| mechanism.forward(c, &joints, &at, &home).unwrap());
        assert!(pose.motion_to(&corner).amax() < 1e-12);
        worst = worst.max(count);
    }
    println!("at most {worst} allocations in one solve");
    assert!(worst <= 2, "{worst} allocations in one solve");
}
