// What is not written can only be read; scalars and colliders lie where constants do.

@group(1) @binding(0) var<uniform> world: World;
/// Where the springs of each particle begin; one more than there are particles.
@group(1) @binding(1) var<storage, read> starts: array<u32>;
@group(1) @binding(2) var<storage, read> springs: array<Spring>;
@group(2) @binding(0) var<storage, read> input: array<Particle>;
@group(2) @binding(1) var<storage, read_write> result: array<Particle>;
