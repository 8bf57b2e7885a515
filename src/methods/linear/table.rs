//! How many sub-pixels of a regular grid lie within circles, as a table for the GPU.
//!
//! In units of half a sub-pixel all sub-pixels lie at whole numbers, and so do the squares of
//! their distances from a circle's centre: how many lie within it depends on the least whole
//! number that is not below its squared radius, and a table of those numbers is exact.

/// Most counts of a table: 4 MB of 16 bits each.
const MOST_COUNTS: usize = 1 << 21;

/// Most pixels along an axis: few sub-pixels have few counts, and a single one has none.
const MOST_REACH: u32 = 128;

/// Counts for the pixels around a circle's own one, as far as they fit.
#[derive(Clone, Debug, Default)]
pub struct CoverageTable {
    /// Pixels along an axis that it has.
    pub reach: u32,
    /// By pixel `x (x + 1) / 2 + y`, y up to x: where its counts begin.
    pub begins: Vec<u32>,
    /// Two a word, the first one in the lower half. Count k of a pixel is how many squared
    /// distances of its sub-pixels are at most the least of them, and k more.
    pub counts: Vec<u32>,
}

impl CoverageTable {
    /// For `side` sub-pixels along each side of a pixel, 1 to 255, in at most so many bytes.
    pub fn new(side: u32, most_bytes: u64) -> Self {
        let most_counts = usize::try_from(most_bytes / 2).map_or(MOST_COUNTS, |most| most.min(MOST_COUNTS));
        let mut begins = vec![0];
        let mut counts: Vec<u16> = Vec::new();
        let mut reach = 0;
        while reach < MOST_REACH {
            let long = reach + 1;
            let of_column: Vec<Vec<u16>> = (0..=long).map(|short| counts_of(side, long, short)).collect();
            if counts.len() + of_column.iter().map(Vec::len).sum::<usize>() > most_counts {
                break;
            }
            for of_pixel in of_column {
                begins.push(counts.len() as u32);
                counts.extend(of_pixel);
            }
            reach = long;
        }
        // A buffer holds something.
        counts.resize(counts.len().max(1), 0);
        let pair = |pair: &[u16]| u32::from(pair[0]) | u32::from(pair.get(1).copied().unwrap_or(0)) << 16;
        Self { reach, begins, counts: counts.chunks(2).map(pair).collect() }
    }
}

/// The counts of the pixel `(long, short)` px away.
fn counts_of(side: u32, long: u32, short: u32) -> Vec<u16> {
    let side = i64::from(side);
    let axis = |px: u32| (0..side).map(move |cell| 2 * side * i64::from(px) - (side - 1) + 2 * cell);
    let mut distances: Vec<i64> = axis(long).flat_map(|x| axis(short).map(move |y| x * x + y * y)).collect();
    distances.sort_unstable();
    let (nearest, farthest) = (distances[0], distances[distances.len() - 1]);
    let mut within = 0;
    let count = |distance: i64| {
        while within < distances.len() && distances[within] <= distance {
            within += 1;
        }
        within as u16
    };
    (nearest..farthest).map(count).collect()
}

#[cfg(test)]
mod tests {
    use super::super::circle::{CircleSampling, Circles, Coverage};
    use super::CoverageTable;

    /// The table's count of sub-pixels within a circle.
    fn looked_up(table: &CoverageTable, side: u32, radius_px: f64, [long, short]: [u32; 2]) -> f64 {
        let side = f64::from(side);
        let squared_radius = (2.0 * side * radius_px).powi(2);
        let nearest_on = |px: u32| (2.0 * side * f64::from(px) - (side - 1.0)).max((side + 1.0) % 2.0);
        let farthest_on = |px: u32| 2.0 * side * f64::from(px) + side - 1.0;
        let nearest = nearest_on(long).powi(2) + nearest_on(short).powi(2);
        if squared_radius <= nearest {
            return 0.0;
        }
        if squared_radius > farthest_on(long).powi(2) + farthest_on(short).powi(2) {
            return 1.0;
        }
        let entry =
            table.begins[(long * (long + 1) / 2 + short) as usize] + (squared_radius.ceil() - nearest) as u32 - 1;
        f64::from(table.counts[(entry / 2) as usize] >> (16 * (entry & 1)) & 0xffff) / (side * side)
    }

    #[test]
    fn the_table_counts_what_circles_cover() {
        for side in [1, 2, 5, 10, 32] {
            let table = CoverageTable::new(side, u64::MAX);
            assert!(table.reach >= 4, "{side} sub-pixels: reach {}", table.reach);
            let circles = Circles::new(CircleSampling { coverage: Coverage::Uniform, sub_pixels: side });
            for step in 0..400 {
                let radius_px = 0.503 + 0.0171 * f64::from(step);
                let long = 1 + step % table.reach.min(7);
                let short = (step / 7) % (long + 1);
                let found = looked_up(&table, side, radius_px, [long, short]);
                let wanted = circles.coverage(radius_px, long, short);
                assert!(
                    (found - wanted).abs() < 1e-9,
                    "side {side}, radius {radius_px}, ({long}, {short}): {found}, {wanted}"
                );
            }
        }
    }
}
