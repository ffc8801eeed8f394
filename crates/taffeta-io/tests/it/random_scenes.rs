//! Scenes at random: those within the limits run, those beyond are refused before they take memory.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::fmt::Write;
use taffeta::{Options, Simulation};
use taffeta_io::parse_scene;

/// Counts what each thread allocates.
struct Counting;

thread_local! {
    static TAKEN: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: every call goes to the system's allocator as it is.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        TAKEN.set(TAKEN.get() + layout.size());
        // SAFETY: the caller keeps the contract.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the contract.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// Memory [byte] that a refusal may take, all in all: the text as a tree, and the words of the error.
const REFUSAL: usize = 1 << 20;

/// Knuth's generator (The Art of Computer Programming 2, 1997).
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A whole number from `low` to `high`.
    fn whole(&mut self, low: u32, high: u32) -> u32 {
        low + (self.unit() * f64::from(high - low + 1)) as u32
    }

    /// A number whose logarithm is anywhere between those of `low` and `high`.
    fn scale(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.unit())
    }

    fn chance(&mut self, share: f64) -> bool {
        self.unit() < share
    }

    fn vector(&mut self, size: f64) -> String {
        let mut number = || size * (2.0 * self.unit() - 1.0);
        format!("[{:?}, {:?}, {:?}]", number(), number(), number())
    }

    /// A direction that is one.
    fn direction(&mut self) -> String {
        format!("[{:?}, 1.0, {:?}]", self.unit(), -self.unit())
    }
}

/// A scene within the limits.
fn scene(random: &mut Random) -> String {
    let dt = random.scale(1e-4, 0.05);
    let mut text = format!("title = \"at random\"\n[time]\ndt = {dt:?}\n");
    if random.chance(0.5) {
        let _ = writeln!(text, "max_step = {:?}", dt / random.scale(0.5, 30.0));
    }
    let _ = writeln!(text, "[world]\ngravity = {}\nwind_force = {}", random.vector(20.0), random.vector(1.0));
    let _ = writeln!(text, "drag = {:?}", random.scale(1e-6, 1.0));
    solver(&mut text, random);
    let bodies = random.whole(1, 3);
    (0..bodies).for_each(|index| body(&mut text, index, random));
    (0..random.whole(0, 2)).for_each(|_| collider(&mut text, random));
    (0..random.whole(0, 2)).for_each(|_| force(&mut text, bodies, random));
    text
}

/// Any method, with any settings of it.
fn solver(text: &mut String, random: &mut Random) {
    let method = ["springs", "ice", "acad"][random.whole(0, 2) as usize];
    let forms = ["compliant", "printed", "primal"];
    let ice = forms[random.whole(0, 2) as usize];
    let acad = forms[random.whole(0, 1) as usize];
    let _ = writeln!(text, "[solver]\nmethod = \"{method}\"\nice.form = \"{ice}\"\nacad.form = \"{acad}\"");
    let primal = ice == "primal" && method == "ice";
    let _ = writeln!(text, "ice.tolerance = {:?}", random.scale(1e-12, 0.9));
    let _ = writeln!(text, "ice.max_iterations = {}", random.whole(1, 50));
    if primal {
        let _ = writeln!(text, "ice.newton_steps = {}", random.whole(0, 3));
    } else {
        let _ = writeln!(text, "ice.epsilon = {:?}", random.unit());
    }
    let _ = writeln!(text, "ice.warm_start = {}", random.chance(0.5));
    let threshold = random.scale(1e-6, 10.0);
    let _ = writeln!(text, "acad.threshold = {threshold:?}\nacad.release = {:?}", threshold * random.unit());
    let _ =
        writeln!(text, "acad.target = {:?}\nacad.epsilon = {:?}", threshold * random.unit(), random.unit());
}

fn mesh(random: &mut Random) -> (String, bool) {
    let size = random.scale(1e-3, 100.0);
    let [a, b] = [random.whole(3, 9), random.whole(3, 9)];
    match random.whole(0, 8) {
        0 => (format!("grid = {{ rows = {a}, cols = {b}, size = [{size:?}, {:?}] }}", 2.0 * size), false),
        1 => (format!("chain = {{ links = {a}, length = {size:?} }}"), false),
        2 => (format!("icosphere = {{ radius = {size:?}, subdivisions = {} }}", a % 3), true),
        3 => (format!("uv_sphere = {{ radius = {size:?}, rings = {a}, segments = {b} }}"), true),
        4 => {
            let minor = 0.4 * size;
            (format!("torus = {{ major = {size:?}, minor = {minor:?}, rings = {a}, segments = {b} }}"), true)
        }
        5 => (format!("cube = {{ size = {size:?}, divisions = {a} }}"), true),
        6 => {
            let (edge, pattern) = (size / f64::from(a), ["grid", "equilateral"][random.whole(0, 1) as usize]);
            let sizes = format!("[{size:?}, {:?}]", 0.7 * size);
            (format!("sheet = {{ size = {sizes}, edge = {edge:?}, pattern = \"{pattern}\" }}"), false)
        }
        7 => (format!("disc = {{ radius = {size:?}, edge = {:?} }}", size / f64::from(a)), false),
        _ => (format!("cylinder = {{ radius = {size:?}, height = {:?}, segments = {a} }}", 2.0 * size), true),
    }
}

fn body(text: &mut String, index: u32, random: &mut Random) {
    let (mesh, closed) = mesh(random);
    let soft = closed && random.chance(0.5);
    let kind = if soft { "soft" } else { "cloth" };
    let mass = ["node_mass", "mass", if soft { "density" } else { "mass" }][random.whole(0, 2) as usize];
    let _ = writeln!(text, "[[body]]\nname = \"body {index}\"\nkind = \"{kind}\"\nmesh.{mesh}");
    let _ = writeln!(text, "{mass} = {:?}", random.scale(1e-6, 1e3));
    let fit = if random.chance(0.5) { "fit" } else { "scale" };
    let _ = writeln!(
        text,
        "[body.place]\nposition = {}\n{fit} = {:?}",
        random.vector(10.0),
        random.scale(0.01, 10.0)
    );
    let _ = writeln!(
        text,
        "rotation = {{ axis = {}, degrees = {:?} }}",
        random.direction(),
        720.0 * random.unit()
    );
    let _ = writeln!(text, "[body.springs]");
    let grid = mesh.starts_with("grid");
    for kind in ["structural", "shear", "bend", "hinge"] {
        if random.chance(0.7) && (grid || kind != "shear") {
            let (k, d) = (random.scale(1e-6, 1e5), random.scale(1e-6, 1.0));
            let _ = writeln!(text, "{kind} = {{ k = {k:?}, d = {d:?} }}");
        }
    }
    // A cube has room for struts, however coarse it is.
    if soft && mesh.starts_with("cube") && random.chance(0.5) {
        let count = random.whole(0, 3);
        let _ = writeln!(
            text,
            "internal = {{ count = {count}, k = 10.0, seed = {} }}",
            random.whole(0, u32::MAX - 1)
        );
    }
    if random.chance(0.6) {
        let _ = writeln!(text, "[[body.pin]]\nselect = {{ nodes = [0, 2] }}");
        motion(text, "body.pin.motion", random);
    }
}

/// Keyframes of rising times.
fn motion(text: &mut String, name: &str, random: &mut Random) {
    let mut time = 0.0;
    for _ in 0..random.whole(0, 3) {
        let _ = writeln!(text, "[[{name}]]\nt = {time:?}\ntranslate = {}", random.vector(1.0));
        let degrees = 360.0 * random.unit();
        let _ = writeln!(text, "rotate = {{ axis = {}, degrees = {degrees:?} }}", random.direction());
        time += random.scale(1e-6, 1.0);
    }
}

fn collider(text: &mut String, random: &mut Random) {
    let shape = if random.chance(0.5) {
        format!("sphere = {{ center = {}, radius = {:?} }}", random.vector(5.0), random.scale(1e-3, 5.0))
    } else {
        format!("plane = {{ point = {}, normal = {} }}", random.vector(5.0), random.direction())
    };
    let _ = writeln!(text, "[[collider]]\n{shape}\noffset = {:?}", 0.1 * random.unit());
    let _ = writeln!(text, "friction = {:?}\nrestitution = {:?}", 2.0 * random.unit(), random.unit());
    motion(text, "collider.motion", random);
}

fn force(text: &mut String, bodies: u32, random: &mut Random) {
    let body = random.whole(0, bodies - 1);
    let what = if random.chance(0.5) {
        format!("force = {}", random.vector(100.0))
    } else {
        format!("torque = {{ axis = {}, value = {:?} }}", random.direction(), random.unit())
    };
    let _ = writeln!(text, "[[force]]\nbody = \"body {body}\"\nselect = {{ nodes = [1, 2] }}\n{what}");
    let _ = writeln!(text, "[[force.motion]]\nt = {:?}\nscale = {:?}", random.unit(), random.unit());
}

#[test]
fn scenes_within_the_limits_run_or_say_where_they_blow_up() {
    let mut random = Random(5);
    let mut ran = 0;
    for round in 0..1000 {
        let text = scene(&mut random);
        let loaded = parse_scene(&text, "scene.toml", &[]).unwrap_or_else(|e| panic!("{round}: {e}\n{text}"));
        let options = Options { threads: Some(1), ..Options::default() };
        let mut simulation =
            Simulation::new(&loaded.scene, &options).unwrap_or_else(|e| panic!("{round}: {e}\n{text}"));
        let mut places: Vec<[f64; 3]> = Vec::new();
        // A frame that is not finite ends the run, and is not shown.
        let whole = (0..2).all(|_| simulation.step().is_ok());
        simulation.positions_f64(&mut places);
        assert!(!whole || places.iter().flatten().all(|x| x.is_finite()), "{round}\n{text}");
        ran += usize::from(whole);
    }
    assert!(ran > 300, "only {ran} of 1000 ran");
}

const PLAIN: &str = r#"[solver]
method = "acad"
[time]
dt = 0.01
frames = 2
[[body]]
name = "a"
kind = "soft"
mass = 1.0
mesh.cube = { size = 1.0, divisions = 2 }
springs.structural = { k = 100.0 }
[[body]]
name = "b"
mass = 1.0
mesh.grid = { rows = 3, cols = 3, size = [1.0, 1.0] }
springs.structural = { k = 100.0 }
[[collider]]
sphere = { center = [0.0, -9.0, 0.0], radius = 1.0 }
"#;

/// What a scene may be set to, and must not be.
const BEYOND: &[&str] = &[
    "time.dt=0",
    "time.dt=-0.01",
    "time.dt=nan",
    "time.dt=inf",
    "time.frames=0",
    "time.frames=-1",
    "time.frames=4294967296",
    "time.max_step=0.0",
    "time.max_step=1e-300",
    // 2^40 sub-steps.
    "time.max_step=9.09e-15",
    "world.drag=-1.0",
    "solver.ice.tolerance=0",
    "solver.ice.tolerance=1",
    "solver.ice.tolerance=nan",
    "solver.ice.max_iterations=0",
    "solver.ice.max_iterations=4294967296",
    "solver.ice.epsilon=-1",
    "solver.ice.order=0",
    "solver.ice.order=2",
    "solver.ice.newton_steps=2",
    "solver.ice.newton_steps=4294967296",
    "solver={ method = \"ice\", ice = { form = \"primal\", epsilon = 0.1 } }",
    "solver={ method = \"ice\", ice = { form = \"primal\", newton_steps = 4294967295 } }",
    "solver.acad.form=primal",
    "solver.acad.threshold=0",
    "solver.acad.release=0.11",
    "solver.acad.target=-0.1",
    "solver.acad.epsilon=inf",
    "world.gravity=[0.0, -inf, 0.0]",
    "world.gravity=[0.0, 1.0]",
    "body.a.mass=0.0",
    "body.a.mass=-1.0",
    "body.a.mass=nan",
    "body.a.density=1.0",
    "body.a.place.scale=0.0",
    "body.a.place.fit=-1.0",
    "body.a.place.position=[nan, 0.0, 0.0]",
    "body.a.place.rotation={ axis = [0.0, 0.0, 0.0], degrees = 1.0 }",
    "body.a.springs.structural.k=-1.0",
    "body.a.springs.structural.d=inf",
    "body.a.springs.internal={ count = 4294967295, k = 1.0 }",
    "body.a.springs.internal={ count = 4294967296, k = 1.0 }",
    "body.a.springs.internal={ count = 2, k = 1.0, seed = -1 }",
    "body.a.mesh={ cube = { size = 1.0, divisions = 4294967295 } }",
    "body.a.mesh={ cube = { size = 1.0, divisions = 0 } }",
    "body.a.mesh={ cube = { size = -1.0, divisions = 2 } }",
    "body.a.mesh={ icosphere = { radius = 1.0, subdivisions = 4294967295 } }",
    "body.a.mesh={ uv_sphere = { radius = 1.0, rings = 4294967295, segments = 4294967295 } }",
    "body.a.mesh={ torus = { major = 1.0, minor = 0.1, rings = 4294967295, segments = 3 } }",
    "body.a.mesh={ torus = { major = 1.0, minor = 2.0, rings = 3, segments = 3 } }",
    "body.a.mesh={ cylinder = { radius = 1.0, height = 1.0, segments = 4294967295, rings = 4294967295 } }",
    "body.b.mesh={ chain = { links = 4294967295, length = 1.0 } }",
    "body.b.mesh={ sheet = { size = [1.0, 1.0], edge = 1e-5 } }",
    "body.b.mesh={ sheet = { size = [1e6, 1e6], edge = 1e-300 } }",
    "body.b.mesh={ sheet = { size = [1.0, 0.0] } }",
    "body.b.mesh={ disc = { radius = 1.0, edge = 1e-5 } }",
    "body.b.mesh={ disc = { radius = 1e6, edge = 1e-9 } }",
    "body.b.mesh={ disc = { radius = 1.0, edge = -0.1 } }",
    "body.b.mesh.grid.rows=4294967295",
    "body.b.mesh.grid.rows=4294967296",
    "body.b.mesh.grid.rows=-3",
    "body.b.mesh.grid.cols=0",
    "body.b.mesh.grid.size=[0.0, 1.0]",
    "body.b.mesh.grid.size=[inf, 1.0]",
    "body.b.pin=[{ select = { nodes = [4294967295] } }]",
    "body.b.pin=[{ select = { rows = [0, 4294967295] } }]",
    "body.b.pin=[{ select = { rows = [2, 1] } }]",
    "body.b.pin=[{ select = { box = { min = [nan, 0.0, 0.0], max = [1.0, 1.0, 1.0] } } }]",
    "body.b.pin=[{ select = { nodes = [0] }, motion = [{ t = 1.0 }, { t = 1.0 }] }]",
    "body.b.springs.internal={ count = 1, k = 1.0 }",
    "collider=[{ sphere = { radius = 0.0 } }]",
    "collider=[{ sphere = { radius = nan } }]",
    "collider=[{ plane = { normal = [0.0, 0.0, 0.0] } }]",
    "collider=[{ plane = {}, restitution = 1.5 }]",
    "collider=[{ plane = {}, offset = -1.0 }]",
    "collider=[{}]",
    "force=[{ body = \"c\", select = {}, force = [0.0, 0.0, 0.0] }]",
    "force=[{ body = \"b\", select = { nodes = [9] }, force = [0.0, 0.0, 0.0] }]",
    "force=[{ body = \"b\", select = {} }]",
];

#[test]
fn scenes_beyond_the_limits_are_refused_before_they_take_memory() {
    let build = |set: Option<&str>| {
        let sets: Vec<String> = set.map(str::to_owned).into_iter().collect();
        let loaded = parse_scene(PLAIN, "scene.toml", &sets).map_err(|error| error.to_string())?;
        let options = Options { threads: Some(1), ..Options::default() };
        Simulation::new(&loaded.scene, &options).map(drop).map_err(|error| error.to_string())
    };
    assert_eq!(build(None), Ok(()));
    for set in BEYOND {
        let before = TAKEN.get();
        let answer = build(Some(set));
        let taken = TAKEN.get() - before;
        assert!(answer.is_err(), "{set} was accepted");
        assert!(taken <= REFUSAL, "{set}: {taken} bytes to say `{}`", answer.unwrap_err());
    }
}

/// Sizes that no node of 32 bits can be at.
#[test]
fn what_is_too_large_to_be_simulated_is_never_shown() {
    let sets = [
        "body.b.mesh.grid.size=[1e300, 1.0]",
        "body.a.mesh.cube.size=1e300",
        "body.a.place.position=[1e300, 0.0, 0.0]",
        "body.a.place.scale=1e300",
        "body.a.mass=1e308",
        "body.a.springs.structural.k=1e308",
        "time.dt=1e300",
        "world.gravity=[0.0, -1e300, 0.0]",
        "world.wind_force=[0.0, 1e308, 0.0]",
    ];
    for set in sets {
        let loaded = parse_scene(PLAIN, "scene.toml", &[set.to_owned()]).unwrap();
        let options = Options { threads: Some(1), ..Options::default() };
        let Ok(mut simulation) = Simulation::new(&loaded.scene, &options) else { continue };
        let mut places: Vec<[f64; 3]> = Vec::new();
        for _ in 0..2 {
            if simulation.step().is_err() {
                break;
            }
            simulation.positions_f64(&mut places);
            assert!(places.iter().flatten().all(|x| x.is_finite()), "{set}");
        }
    }
}
