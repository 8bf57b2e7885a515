//! Structural similarity: Wang, Bovik, Sheikh and Simoncelli, "Image Quality Assessment:
//! From Error Visibility to Structural Similarity" (IEEE TIP 2004), section III.
//!
//! As in the authors' program: a Gaussian window of 11 x 11 px with sigma = 1.5 and unit
//! sum, K1 = 0.01, K2 = 0.03, the mean over the positions where the window fits. The luma
//! is that of its `rgb2gray`, Y' of ITU-R BT.601, on encoded values in [0, 1].

use defocus::image::{ColorImage, Image};
use glam::{DVec3, UVec2, dvec3};
use rayon::prelude::*;

const RADIUS: usize = 5;
const WINDOW: usize = 2 * RADIUS + 1;
const SIGMA: f64 = 1.5;
/// (K1 L)^2 and (K2 L)^2 with the dynamic range L = 1.
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;
const LUMA_601: DVec3 = dvec3(0.299, 0.587, 0.114);

/// Mean SSIM of encoded images of equal size; `None` where the window does not fit.
pub(super) fn mean_ssim(test: &ColorImage, reference: &ColorImage) -> Option<f64> {
    if test.size.min_element() < WINDOW as u32 {
        return None;
    }
    let luma = |image: &ColorImage| image.map(|p| p.as_dvec3().dot(LUMA_601));
    let (a, b) = (luma(test), luma(reference));
    let product = |a: &Image<f64>, b: &Image<f64>| Image {
        size: a.size,
        pixels: a.pixels.iter().zip(&b.pixels).map(|(a, b)| a * b).collect(),
    };
    let means = [&a, &b, &product(&a, &a), &product(&b, &b), &product(&a, &b)].map(window_means);
    let [mean_a, mean_b, mean_aa, mean_bb, mean_ab] = &means;
    let ssim = (0..mean_a.len()).map(|i| {
        let (ma, mb) = (mean_a[i], mean_b[i]);
        let (var_a, var_b, cov) = (mean_aa[i] - ma * ma, mean_bb[i] - mb * mb, mean_ab[i] - ma * mb);
        (2.0 * ma * mb + C1) * (2.0 * cov + C2) / ((ma * ma + mb * mb + C1) * (var_a + var_b + C2))
    });
    Some(ssim.sum::<f64>() / mean_a.len() as f64)
}

/// Means under the window at every position where it fits, rows from top to bottom.
fn window_means(image: &Image<f64>) -> Vec<f64> {
    let kernel = kernel();
    let UVec2 { x: width, y: height } = image.size;
    let valid_width = width as usize + 1 - WINDOW;
    let weighted = |values: &[f64]| values.iter().zip(&kernel).map(|(v, k)| v * k).sum::<f64>();
    let rows: Vec<f64> = image
        .pixels
        .par_chunks_exact(width as usize)
        .flat_map_iter(|row| row.windows(WINDOW).map(weighted).collect::<Vec<_>>())
        .collect();
    (0..height as usize + 1 - WINDOW)
        .into_par_iter()
        .flat_map_iter(|y| {
            let mut sums = vec![0.0; valid_width];
            for (k, row) in kernel.iter().zip(rows[y * valid_width..].chunks_exact(valid_width)) {
                sums.iter_mut().zip(row).for_each(|(sum, value)| *sum += k * value);
            }
            sums
        })
        .collect()
}

fn kernel() -> [f64; WINDOW] {
    let weights: [f64; WINDOW] = std::array::from_fn(|i| {
        let x = i as f64 - RADIUS as f64;
        (-x * x / (2.0 * SIGMA * SIGMA)).exp()
    });
    let sum: f64 = weights.iter().sum();
    weights.map(|w| w / sum)
}
