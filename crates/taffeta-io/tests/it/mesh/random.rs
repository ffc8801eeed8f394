//! A closed mesh stays the same solid, however its file is written.

use super::{load, obj, volume_and_closed};

/// Knuth's linear congruential generator (The Art of Computer Programming, vol. 2, 1997, 3.3.4).
struct Random(u64);

impl Random {
    fn below(&mut self, count: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % count
    }

    fn shuffle<T>(&mut self, items: &mut [T]) {
        (1..items.len()).for_each(|i| items.swap(i, self.below(i + 1)));
    }
}

/// A torus, and in its tube a smaller one that bounds a cavity: places, faces.
fn hollow_torus() -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let (rings, segments) = (12_u32, 8_u32);
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for (tube, first) in [(0.4, 0), (0.2, rings * segments)] {
        let at = |ring: u32, segment: u32| first + ring % rings * segments + segment % segments;
        for (ring, segment) in (0..rings).flat_map(|r| (0..segments).map(move |s| (r, s))) {
            let turn = |i: u32, of: u32| (f64::from(i) / f64::from(of) * std::f64::consts::TAU).sin_cos();
            let ((sin, cos), (rise, out)) = (turn(ring, rings), turn(segment, segments));
            let radius = 1.0 + tube * out;
            vertices.push([radius * cos, tube * rise, radius * sin]);
            let [a, b] = [at(ring, segment), at(ring, segment + 1)];
            let [c, d] = [at(ring + 1, segment), at(ring + 1, segment + 1)];
            let pair = [[a, b, c], [b, d, c]];
            faces.extend(if first == 0 { pair } else { pair.map(|[a, b, c]| [a, c, b]) });
        }
    }
    (vertices, faces)
}

/// Writes the mesh in another way: in another order, turned here and there, with vertices and faces twice, and flat ones.
fn rewritten(vertices: &[[f64; 3]], faces: &[[u32; 3]], random: &mut Random) -> String {
    let mut faces = faces.to_vec();
    (0..5).for_each(|_| faces.push(faces[random.below(faces.len())]));
    for _ in 0..5 {
        let [a, b] = [0; 2].map(|_| random.below(vertices.len()) as u32);
        faces.push([a, b, b]);
    }
    let everything = random.below(2) == 0;
    for face in &mut faces {
        face.rotate_left(random.below(3));
        // Less than half of them, so that the majority is on the file's side.
        if (random.below(4) == 0) ^ everything {
            face.swap(0, 1);
        }
    }
    random.shuffle(&mut faces);
    let mut order: Vec<u32> = (0..vertices.len() as u32).collect();
    (0..50).for_each(|_| order.push(random.below(vertices.len()) as u32));
    random.shuffle(&mut order);
    let places: Vec<[f64; 3]> = order.iter().map(|&vertex| vertices[vertex as usize]).collect();
    for vertex in faces.as_flattened_mut() {
        let copies: Vec<u32> =
            (0..).zip(&order).filter(|(_, old)| *old == vertex).map(|(new, _)| new).collect();
        *vertex = copies[random.below(copies.len())];
    }
    obj(&places, &faces)
}

#[test]
fn a_solid_is_the_same_however_its_file_is_written() {
    let (vertices, faces) = hollow_torus();
    let plain = load(&obj(&vertices, &faces)).unwrap();
    let (volume, closed) = volume_and_closed(&plain);
    assert!(closed && volume > 1.0, "{volume}");
    assert_eq!(plain.repairs, Vec::<String>::new());
    for seed in 0..60 {
        let text = rewritten(&vertices, &faces, &mut Random(seed));
        let surface = load(&text).unwrap();
        let (found, closed) = volume_and_closed(&surface);
        assert!(closed && (found / volume - 1.0).abs() < 1e-12, "seed {seed}: {found}, closed: {closed}");
        assert_eq!(
            (surface.nodes.len(), surface.triangles.len()),
            (vertices.len(), faces.len()),
            "seed {seed}"
        );
        let again = load(&text).unwrap();
        assert_eq!((&again.nodes, &again.triangles), (&surface.nodes, &surface.triangles), "seed {seed}");
    }
}
