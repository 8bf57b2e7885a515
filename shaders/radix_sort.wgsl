// Radix sort of (key, value) pairs, least significant digit first, stable
// (src/gpu/radix_sort.rs).
//
// For each digit of 4 bits: `count_digits` counts the digits of every tile, `scan_counts`
// turns the counts, ordered by digit and then by tile, into where each tile's pairs of
// each digit go, and `move_pairs` moves them. A thread owns neighbouring pairs and walks
// them in order, which is what keeps the sort stable.

struct Digit {
    len: u32,
    /// Least significant bit of the digit.
    shift: u32,
    tiles: u32,
}

@group(0) @binding(0) var<uniform> digit: Digit;
@group(0) @binding(1) var<storage, read> keys: array<u32>;
@group(0) @binding(2) var<storage, read> values: array<u32>;
@group(0) @binding(3) var<storage, read_write> sorted_keys: array<u32>;
@group(0) @binding(4) var<storage, read_write> sorted_values: array<u32>;
@group(0) @binding(5) var<storage, read_write> counts: array<u32>;

const DIGITS = 16u;
const THREADS = 128u;
const PAIRS_PER_THREAD = 8u;
const PAIRS_PER_TILE = 1024u;

fn digit_of(key: u32) -> u32 {
    return (key >> digit.shift) & (DIGITS - 1u);
}

var<workgroup> tile_counts: array<atomic<u32>, DIGITS>;

@compute @workgroup_size(THREADS)
fn count_digits(@builtin(workgroup_id) tile: vec3u, @builtin(local_invocation_index) thread: u32) {
    for (var k = 0u; k < PAIRS_PER_THREAD; k++) {
        let i = tile.x * PAIRS_PER_TILE + k * THREADS + thread;
        if i < digit.len {
            atomicAdd(&tile_counts[digit_of(keys[i])], 1u);
        }
    }
    workgroupBarrier();
    if thread < DIGITS {
        counts[thread * digit.tiles + tile.x] = atomicLoad(&tile_counts[thread]);
    }
}

const SCAN_THREADS = 256u;
var<workgroup> partial_sums: array<u32, SCAN_THREADS>;

/// Replaces counts by the sums of those before them. One workgroup: the counts are a
/// sixty-fourth of the keys.
@compute @workgroup_size(SCAN_THREADS)
fn scan_counts(@builtin(local_invocation_index) thread: u32) {
    let total = DIGITS * digit.tiles;
    let share = (total + SCAN_THREADS - 1u) / SCAN_THREADS;
    let first = min(thread * share, total);
    let end = min(first + share, total);
    var sum = 0u;
    for (var i = first; i < end; i++) {
        sum += counts[i];
    }
    partial_sums[thread] = sum;
    workgroupBarrier();
    for (var step = 1u; step < SCAN_THREADS; step *= 2u) {
        var before = 0u;
        if thread >= step {
            before = partial_sums[thread - step];
        }
        workgroupBarrier();
        partial_sums[thread] += before;
        workgroupBarrier();
    }
    var next = partial_sums[thread] - sum;
    for (var i = first; i < end; i++) {
        let count = counts[i];
        counts[i] = next;
        next += count;
    }
}

/// Of each digit and thread, ordered by digit and then by thread: first the count, then
/// the place within the tile's pairs sorted by this digit.
var<workgroup> places: array<u32, 2048>;
var<workgroup> thread_sums: array<u32, THREADS>;
var<workgroup> digit_starts: array<u32, DIGITS>;

@compute @workgroup_size(THREADS)
fn move_pairs(@builtin(workgroup_id) tile: vec3u, @builtin(local_invocation_index) thread: u32) {
    let first = tile.x * PAIRS_PER_TILE + thread * PAIRS_PER_THREAD;
    let end = min(first + PAIRS_PER_THREAD, digit.len);
    for (var i = first; i < end; i++) {
        places[digit_of(keys[i]) * THREADS + thread] += 1u;
    }
    workgroupBarrier();
    scan_places(thread);
    if thread < DIGITS {
        digit_starts[thread] = places[thread * THREADS];
    }
    workgroupBarrier();
    for (var i = first; i < end; i++) {
        let key = keys[i];
        let d = digit_of(key);
        let place = places[d * THREADS + thread];
        places[d * THREADS + thread] = place + 1u;
        let to = counts[d * digit.tiles + tile.x] + place - digit_starts[d];
        sorted_keys[to] = key;
        sorted_values[to] = values[i];
    }
}

/// Replaces `places` by the sums of those before them; each thread takes 16.
fn scan_places(thread: u32) {
    var sum = 0u;
    for (var i = 0u; i < DIGITS; i++) {
        sum += places[thread * DIGITS + i];
    }
    thread_sums[thread] = sum;
    workgroupBarrier();
    for (var step = 1u; step < THREADS; step *= 2u) {
        var before = 0u;
        if thread >= step {
            before = thread_sums[thread - step];
        }
        workgroupBarrier();
        thread_sums[thread] += before;
        workgroupBarrier();
    }
    var next = thread_sums[thread] - sum;
    for (var i = 0u; i < DIGITS; i++) {
        let count = places[thread * DIGITS + i];
        places[thread * DIGITS + i] = next;
        next += count;
    }
    workgroupBarrier();
}
