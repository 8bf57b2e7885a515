//! The GPU's sort against the CPU's.

use defocus::gpu::{Gpu, sort_pairs};

/// Keys in no order, with many repeated: `different` values over all 32 bits.
fn keys(len: u32, different: u32) -> Vec<u32> {
    let scatter = |i: u32| (i % different).wrapping_mul(0x9E37_79B9).rotate_left(i % different);
    (0..len).map(|i| scatter(i.wrapping_mul(2_654_435_761) >> 7)).collect()
}

#[test]
fn sorts_as_the_cpu_does_and_keeps_the_order_of_equal_keys() {
    let gpu = Gpu::open(None).unwrap();
    for len in [1, 2, 255, 256, 257, 65_536, 200_003] {
        for different in [3, 1000, u32::MAX] {
            let keys = keys(len, different);
            let mut expected: Vec<(u32, u32)> = keys.iter().copied().zip(0..).collect();
            expected.sort_by_key(|pair| pair.0);

            let key_buffer = gpu.buffer_of("keys", &keys);
            let values: Vec<u32> = (0..len).collect();
            let value_buffer = gpu.buffer_of("values", &values);
            let mut frame = gpu.frame();
            sort_pairs(&mut frame, &key_buffer, &value_buffer, len);
            let sorted_keys: Vec<u32> = frame.read_buffer(&key_buffer);
            let sorted_values: Vec<u32> = frame.read_buffer(&value_buffer);
            let sorted: Vec<_> = sorted_keys.into_iter().zip(sorted_values).collect();
            assert!(sorted == expected, "{len} keys of {different} values are not sorted, or not stably");
        }
    }
}

#[test]
fn keys_beyond_the_length_stay() {
    let gpu = Gpu::open(None).unwrap();
    let keys = gpu.buffer_of("keys", &[5u32, 3, 1, 0]);
    let values = gpu.buffer_of("values", &[0u32, 1, 2, 3]);
    let mut frame = gpu.frame();
    sort_pairs(&mut frame, &keys, &values, 3);
    assert_eq!(frame.read_buffer::<u32>(&keys), [1, 3, 5, 0]);
    assert_eq!(frame.read_buffer::<u32>(&values), [2, 1, 0, 3]);
}
