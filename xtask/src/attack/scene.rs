//! Scenes that are made up at random: most of them are odd, some impossible.

use std::fmt::Write as _;

/// A sequence of numbers that a seed fixes.
pub struct Chance(u64);

impl Chance {
    /// The one of a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5851_f42d_4c95_7f2d)
    }

    /// 64 random bits: splitmix64.
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below that.
    pub fn below(&mut self, end: u64) -> u64 {
        self.bits() % end
    }

    /// Whether something of that probability is.
    fn is(&mut self, probability: f64) -> bool {
        self.even(0.0, 1.0) < probability
    }

    fn pick<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len() as u64) as usize]
    }

    fn even(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// As often in each decade, with six digits.
    fn decades(&mut self, from: f64, to: f64) -> f64 {
        let number = from * (to / from).powf(self.even(0.0, 1.0));
        format!("{number:.5e}").parse().unwrap_or(number)
    }

    fn vector(&mut self, most: f64) -> String {
        let [x, y, z] = [0; 3].map(|_| self.even(-most, most));
        format!("[{x:.4}, {y:.4}, {z:.4}]")
    }

    fn rotation(&mut self) -> String {
        format!("{{ axis = {}, degrees = {:.1} }}", self.vector(1.0), self.even(-400.0, 400.0))
    }
}

/// The scene of a seed, as TOML.
pub fn scene(seed: u64) -> String {
    let mut chance = Chance::new(seed);
    let chance = &mut chance;
    let mut text = format!("title = \"{seed}\"\n");
    time(&mut text, chance);
    world(&mut text, chance);
    sleep(&mut text, chance);
    solver(&mut text, chance);
    let bodies = 1 + chance.below(4) as usize;
    let size = chance.decades(0.05, 2.0);
    let kinds: Vec<Kind> = (0..bodies).map(|number| body(&mut text, chance, number, size)).collect();
    for number in 0..chance.below(3) as usize {
        collider(&mut text, chance, number, size);
    }
    if bodies > 1 && chance.is(0.3) {
        seam(&mut text, chance, &kinds, size);
    }
    if chance.is(0.2) {
        let _ = writeln!(text, "[[force]]\nbody = \"b0\"\nselect = {{ nodes = [0] }}");
        let _ = writeln!(text, "force = {}", {
            let most = chance.decades(1e-4, 1e6);
            chance.vector(most)
        });
    }
    if chance.is(0.25) { spoil(&text, chance) } else { text }
}

fn time(text: &mut String, chance: &mut Chance) {
    let dt = chance.pick(&[1.0 / 60.0, 0.01, 1.0 / 24.0, 0.002]);
    let _ = writeln!(text, "[time]\ndt = {dt}\nframes = {}", 3 + chance.below(10));
    if chance.is(0.7) {
        let _ = writeln!(text, "max_step = {}", chance.decades(1e-4, dt));
    }
}

fn world(text: &mut String, chance: &mut Chance) {
    if chance.is(0.5) {
        let _ = writeln!(text, "[world]\ngravity = {}", chance.vector(15.0));
        if chance.is(0.5) {
            let _ = writeln!(text, "drag = {}", chance.decades(1e-6, 10.0));
        }
        if chance.is(0.4) {
            let _ = writeln!(text, "[world.air]\nvelocity = {}", chance.vector(30.0));
            if chance.is(0.5) {
                let (speed, length) = (chance.decades(0.1, 50.0), chance.decades(0.01, 10.0));
                let _ = writeln!(text, "gust = {{ speed = {speed}, length = {length}, seed = 3 }}");
            }
        }
    }
}

fn sleep(text: &mut String, chance: &mut Chance) {
    if chance.is(0.2) {
        let (speed, after) = (chance.decades(1e-3, 10.0), chance.decades(1e-3, 0.1));
        let _ = writeln!(text, "[sleep]\nspeed = {speed}\nafter = {after}");
    }
}

fn solver(text: &mut String, chance: &mut Chance) {
    let lines = chance.pick(&[
        "",
        "",
        "method = \"ice\"",
        "method = \"ice\"\nice.form = \"primal\"",
        "method = \"ice\"\nice.form = \"primal\"",
        "method = \"ice\"\nice = { form = \"primal\", order = 2 }",
        "method = \"ice\"\nice = { form = \"primal\", newton_steps = 1 }",
        "method = \"acad\"",
    ]);
    if !lines.is_empty() {
        let _ = writeln!(text, "[solver]\n{lines}");
    }
}

/// What a body is, as far as others need to know.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Grid,
    Sheet,
    Closed,
    Chain,
}

fn body(text: &mut String, chance: &mut Chance, number: usize, size: f64) -> Kind {
    let kind = chance.pick(&[
        Kind::Grid,
        Kind::Grid,
        Kind::Grid,
        Kind::Sheet,
        Kind::Closed,
        Kind::Closed,
        Kind::Chain,
    ]);
    let is_soft = kind == Kind::Closed && chance.is(0.6);
    let _ = writeln!(text, "[[body]]\nname = \"b{number}\"\nmesh.{}", mesh(chance, kind, size));
    if is_soft {
        text.push_str("kind = \"soft\"\n");
    }
    place(text, chance, "", size);
    if chance.is(0.3) {
        let _ = writeln!(text, "velocity = {}", {
            let most = chance.decades(0.1, 300.0);
            chance.vector(most)
        });
    }
    let has_fabric = matches!(kind, Kind::Grid | Kind::Sheet) && chance.is(0.35);
    if has_fabric {
        let preset = chance.pick(&["cotton", "silk", "denim", "jersey"]);
        let _ = writeln!(text, "material = {{ preset = \"{preset}\" }}");
    } else {
        let mass = chance.pick(&["node_mass", "mass"]);
        let _ = writeln!(text, "{mass} = {}", chance.decades(1e-5, 1.0));
        springs(text, chance, kind, is_soft);
    }
    if kind != Kind::Chain && chance.is(0.75) {
        let form = chance.pick(&["", "", "", "form = \"nodes\", "]);
        let thickness =
            if chance.is(0.9) { size * chance.decades(1e-3, 0.1) } else { chance.decades(1e-6, 10.0) };
        let _ = writeln!(
            text,
            "self_collision = {{ {form}thickness = {thickness:.3e}, friction = {:.2} }}",
            chance.even(0.0, 1.2)
        );
    }
    if is_soft && chance.is(0.6) {
        let form = chance.pick(&["corrected", "projected"]);
        let _ = writeln!(text, "volume = {{ form = \"{form}\", target = {:.3} }}", chance.decades(0.3, 3.0));
    }
    pins(text, chance, size);
    kind
}

fn mesh(chance: &mut Chance, kind: Kind, size: f64) -> String {
    let many = |chance: &mut Chance| 2 + chance.below(18);
    match kind {
        Kind::Grid => {
            let (rows, cols) = (many(chance), many(chance));
            format!(
                "grid = {{ rows = {rows}, cols = {cols}, size = [{size:.4}, {:.4}] }}",
                size * chance.decades(0.2, 2.0)
            )
        }
        Kind::Sheet => format!(
            "sheet = {{ size = [{size:.4}, {size:.4}], edge = {:.4} }}",
            size * chance.decades(0.07, 0.5)
        ),
        Kind::Chain => format!("chain = {{ links = {}, length = {size:.4} }}", many(chance)),
        Kind::Closed => match chance.below(4) {
            0 => format!("icosphere = {{ radius = {:.4}, subdivisions = {} }}", 0.4 * size, chance.below(4)),
            1 => format!("cube = {{ size = {:.4}, divisions = {} }}", 0.7 * size, 1 + chance.below(6)),
            2 => format!(
                "torus = {{ major = {:.4}, minor = {:.4}, rings = 12, segments = {} }}",
                0.4 * size,
                0.15 * size,
                3 + chance.below(8)
            ),
            _ => format!(
                "cylinder = {{ radius = {:.4}, height = {size:.4}, segments = 8, rings = {} }}",
                0.2 * size,
                1 + chance.below(6)
            ),
        },
    }
}

fn place(text: &mut String, chance: &mut Chance, prefix: &str, size: f64) {
    let _ = writeln!(text, "{prefix}place.position = {}", chance.vector(0.7 * size));
    if chance.is(0.5) {
        let _ = writeln!(text, "{prefix}place.rotation = {}", chance.rotation());
    }
}

fn springs(text: &mut String, chance: &mut Chance, kind: Kind, is_soft: bool) {
    let pair = |chance: &mut Chance| (chance.decades(0.1, 1e6), chance.decades(1e-5, 10.0));
    let mut add = |name: &str, chance: &mut Chance, more: &str| {
        let (k, d) = pair(chance);
        let _ = writeln!(text, "springs.{name} = {{ {more}k = {k}, d = {d} }}");
    };
    add("structural", chance, "");
    if kind == Kind::Grid && chance.is(0.6) {
        add("shear", chance, "");
    }
    if chance.is(0.5) {
        add("bend", chance, "");
    } else if kind != Kind::Chain && chance.is(0.3) {
        add("hinge", chance, "");
    }
    if is_soft && chance.is(0.4) {
        add("internal", chance, "count = 40, ");
    }
}

fn pins(text: &mut String, chance: &mut Chance, size: f64) {
    if chance.is(0.5) {
        return;
    }
    text.push_str("[[body.pin]]\nselect = { nodes = [0, 1] }\n");
    if chance.is(0.1) {
        let _ = writeln!(text, "break_force = {}", chance.decades(1e-3, 1e3));
    }
    if chance.is(0.4) {
        motion(text, chance, "body.pin.motion", size);
    }
}

fn motion(text: &mut String, chance: &mut Chance, table: &str, size: f64) {
    let far = if chance.is(0.1) { 1e3 * size } else { 2.0 * size };
    let _ =
        writeln!(text, "[[{table}]]\nt = {}\ntranslate = {}", chance.decades(0.01, 0.5), chance.vector(far));
    if chance.is(0.4) {
        let _ = writeln!(text, "rotate = {}", chance.rotation());
    }
}

fn collider(text: &mut String, chance: &mut Chance, number: usize, size: f64) {
    let at = chance.vector(0.6 * size);
    let shape = match chance.below(8) {
        0 => format!("sphere = {{ center = {at}, radius = {:.4} }}", size * chance.decades(0.02, 0.6)),
        1 => format!(
            "box = {{ center = {at}, half = [{:.4}, {:.4}, {:.4}] }}",
            0.3 * size,
            size * chance.decades(0.01, 0.5),
            0.2 * size
        ),
        2 => format!(
            "capsule = {{ a = {at}, b = {}, radius = {:.4} }}",
            chance.vector(0.6 * size),
            size * chance.decades(0.01, 0.3)
        ),
        3 => format!(
            "cylinder = {{ a = {at}, b = {}, radius = {:.4} }}",
            chance.vector(0.6 * size),
            size * chance.decades(0.01, 0.3)
        ),
        4 => format!(
            "mesh = {{ torus = {{ major = {:.4}, minor = {:.4}, rings = 12, segments = 8 }} }}",
            0.4 * size,
            0.1 * size
        ),
        5 => format!("convex = {{ cube = {{ size = {:.4}, divisions = 1 }} }}", 0.5 * size),
        6 => format!("mesh = {{ grid = {{ rows = 2, cols = 3, size = [{size:.4}, {size:.4}] }} }}"),
        _ => format!("plane = {{ point = [0.0, {:.4}, 0.0] }}", -size * chance.even(0.0, 1.0)),
    };
    let _ = writeln!(text, "[[collider]]\nname = \"c{number}\"\n{shape}");
    if shape.starts_with("mesh") || shape.starts_with("convex") {
        place(text, chance, "", size);
    }
    let _ = writeln!(
        text,
        "offset = {:.3e}\nfriction = {:.2}",
        size * chance.decades(1e-3, 0.1),
        chance.even(0.0, 1.0)
    );
    if chance.is(0.5) {
        motion(text, chance, "collider.motion", size);
    }
}

fn seam(text: &mut String, chance: &mut Chance, kinds: &[Kind], size: f64) {
    if kinds[..2].contains(&Kind::Chain) {
        return;
    }
    let _ = writeln!(
        text,
        "[[seam]]\nfrom = {{ body = \"b0\", select = {{ nodes = [0, 1, 2] }} }}\nto = {{ body = \"b1\", select = {{ nodes = [0, 1, 2] }} }}"
    );
    if chance.is(0.5) {
        let _ = writeln!(text, "k = {}", chance.decades(1.0, 1e5));
    }
    let _ = writeln!(text, "length = {:.4}", size * chance.even(0.0, 0.2));
}

/// Puts something in the place of one number that is hardly meant.
fn spoil(text: &str, chance: &mut Chance) -> String {
    let is_part = |c: char| c.is_ascii_digit() || matches!(c, '.' | '-' | 'e');
    let mut spans = Vec::new();
    let mut at = 0;
    while let Some(found) = text[at..].find(|c: char| c.is_ascii_digit()) {
        let from = at + found;
        let to = text[from..].find(|c| !is_part(c)).map_or(text.len(), |length| from + length);
        // Not a name.
        if !text[..from].ends_with(|c: char| c.is_ascii_alphabetic() || c == '"') {
            spans.push(from..to);
        }
        at = to;
    }
    let span = chance.pick(&(0..spans.len()).collect::<Vec<_>>());
    let odd = [
        "0",
        "-1",
        "0.0",
        "-1.0",
        "nan",
        "inf",
        "1e300",
        "1e-300",
        "-1e30",
        "1e6",
        "1e12",
        "1e-12",
        "65536",
        "4294967295",
        "1e39",
        "\"\"",
        "[]",
    ];
    let mut spoilt = text.to_owned();
    spoilt.replace_range(spans[span].clone(), chance.pick(&odd));
    spoilt
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_makes_up_the_same_scene_again_and_another_one_another() {
        assert_eq!(scene(7), scene(7));
        assert_ne!(scene(7), scene(8));
    }

    #[test]
    fn one_number_of_a_spoilt_scene_is_another() {
        let text = "name = \"b0\"\nk = 1.5e3\n";
        assert!((0..50).all(|seed| {
            let spoilt = spoil(text, &mut Chance::new(seed));
            spoilt.starts_with("name = \"b0\"\nk = ") && spoilt != text
        }));
    }
}
