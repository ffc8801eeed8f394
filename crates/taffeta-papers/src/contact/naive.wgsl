// Everything in storage that could be written, as nothing says that it is not.

@group(1) @binding(0) var<storage, read_write> world: World;
/// Where the springs of each particle begin; one more than there are particles.
@group(1) @binding(1) var<storage, read_write> starts: array<u32>;
@group(1) @binding(2) var<storage, read_write> springs: array<Spring>;
@group(2) @binding(0) var<storage, read_write> input: array<Particle>;
@group(2) @binding(1) var<storage, read_write> result: array<Particle>;
