// The hash PCG of Jarzynski and Olano, "Hash Functions for GPU Rendering" (JCGT 2020).

fn hash(x: u32) -> u32 {
    let state = x * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}
