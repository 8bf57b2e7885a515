// Where the samples of a pixel lie: each has a column and a row of its own, as rooks on a chessboard
// (src/view/fine.rs).

/// By how much a sample lies to the right of its place in a regular grid, samples, by its row of
/// `a_side` a pixel; and below it, by its column. The pixel's first sample lies where it was.
///
/// Two rows that follow each other have the same mean: so have 2x2 samples, wherever they lie.
fn stagger_of(line: f32, a_side: f32) -> f32 {
    let within = line - a_side * floor((line + 0.5) / a_side);
    let pair = floor(0.5 * within);
    return select(pair, a_side - 1.0 - pair, within > 2.0 * pair) / a_side;
}

/// Its mean over a pixel.
fn mean_stagger(a_side: f32) -> f32 {
    return 0.5 - 0.5 / a_side;
}
