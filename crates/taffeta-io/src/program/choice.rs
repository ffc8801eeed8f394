//! Whether a scene gains by a GPU: the decision of `--backend auto`, in numbers.

use taffeta::scene::Scene;
use taffeta::taffeta_gpu::{AdapterInfo, Choice, Gpu};
use taffeta::{GpuCost, Precision};

/// Nodes a second and thread that the CPU backend moves by a sub-step: cloth with all its springs, on current
/// processors (docs/results).
const CPU_NODES: f64 = 280e6;
/// Nodes for each thread of the CPU at least, where the user does not say.
const NODES_A_THREAD: u64 = 4096;
/// The GPU is taken where it is as many times faster: so the choice is the same from run to run.
const FACTOR: f64 = 2.0;
/// Least time of a sub-step on any GPU [s].
const LEAST_SUBSTEP: f64 = 1e-6;
/// Handing a frame to a GPU and waiting for it [s].
const FRAME: f64 = 2e-4;
/// Bringing a node's position and velocity back to the host [s]: 32 bytes at 5 GB/s.
const READ_BACK: f64 = 6.4e-9;

/// What is to be done.
#[derive(Clone, Copy, Debug)]
pub struct Work {
    /// Nodes of all bodies.
    pub nodes: u64,
    /// Sub-steps a frame.
    pub substeps: u32,
    /// Threads that the CPU would use.
    pub threads: usize,
    /// Arithmetic.
    pub precision: Precision,
}

/// What was decided.
#[derive(Debug)]
struct Verdict {
    /// The GPU, and not the CPU.
    gpu: bool,
    /// Why, in words.
    why: String,
}

/// Threads that the machine runs at once.
fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Worker threads where the user asks for a number: no more than run at once, as more would only wait for each other.
pub fn at_once(asked: Option<u16>) -> Option<usize> {
    asked.map(|asked| usize::from(asked).min(cores()))
}

/// What to say where the user asks for more.
pub fn too_many(asked: Option<u16>) -> Option<String> {
    let (asked, cores) = (asked.map(usize::from)?, cores());
    (asked > cores)
        .then(|| format!("--threads {asked}: this machine runs {cores} at once, so {cores} will work"))
}

impl Work {
    /// What `scene` asks for; `threads` where the user says.
    pub fn of(scene: &Scene, threads: Option<u16>, precision: Precision) -> Self {
        let nodes = scene.bodies.iter().fold(0_u64, |sum, body| sum.saturating_add(body.mesh.nodes()));
        let all = cores();
        let useful = || all.min(usize::try_from(nodes / NODES_A_THREAD).unwrap_or(all)).max(1);
        let threads = at_once(threads).unwrap_or_else(useful);
        Self { nodes, substeps: scene.time.substeps(), threads, precision }
    }

    /// Why no GPU needs to be looked for, if so.
    fn needs_no_gpu(&self) -> Option<String> {
        if self.precision == Precision::F64 {
            return Some("a GPU computes in f32".to_owned());
        }
        let small = self.on_cpu() < FACTOR * self.on_gpu(&LEAST);
        small.then(|| "the scene is too small to gain by a GPU".to_owned())
    }

    /// Time of a frame on the CPU [s].
    fn on_cpu(&self) -> f64 {
        f64::from(self.substeps) * self.nodes as f64 / (CPU_NODES * self.threads.max(1) as f64)
    }

    /// Time of a frame on a GPU [s].
    fn on_gpu(&self, cost: &GpuCost) -> f64 {
        let nodes = self.nodes as f64;
        let substep = cost.seconds_per_substep + nodes * cost.seconds_per_node;
        FRAME + nodes * READ_BACK + f64::from(self.substeps) * substep
    }
}

/// A GPU than which none is faster.
const LEAST: GpuCost = GpuCost { seconds_per_substep: LEAST_SUBSTEP, seconds_per_node: 0.0 };

/// The GPU where it gains for the `work`, else the reason for the CPU; and why, in words.
pub fn faster(work: &Work) -> Result<(Gpu, String), String> {
    if let Some(why) = work.needs_no_gpu() {
        return Err(why);
    }
    let gpu = Gpu::open(&Choice::from_env()).map_err(|error| error.to_string())?;
    let Verdict { gpu: gains, why } = choose(work, gpu.info(), || GpuCost::measure(&gpu));
    if gains { Ok((gpu, why)) } else { Err(why) }
}

/// The GPU or the CPU. `adapter` is the best there is, `cost` measures it; what it says where it cannot is the reason
/// for the CPU.
fn choose(work: &Work, adapter: &AdapterInfo, cost: impl FnOnce() -> Result<GpuCost, String>) -> Verdict {
    let cpu = |why| Verdict { gpu: false, why };
    if let Some(why) = work.needs_no_gpu() {
        return cpu(why);
    }
    if adapter.is_software() {
        return cpu(only_software(adapter));
    }
    match cost() {
        Ok(cost) => compare(work, adapter, &cost),
        Err(why) => cpu(format!("{adapter} failed: {why}")),
    }
}

/// Why a software adapter is not taken unless it is asked for.
pub fn only_software(adapter: &AdapterInfo) -> String {
    format!("only a software adapter ({}) is there", adapter.name)
}

fn compare(work: &Work, adapter: &AdapterInfo, cost: &GpuCost) -> Verdict {
    let (cpu, on_gpu) = (work.on_cpu(), work.on_gpu(cost));
    let gpu = FACTOR * on_gpu <= cpu;
    let threads =
        if work.threads > 1 { format!("{} CPU threads", work.threads) } else { "the CPU".to_owned() };
    let times = format!("about {:.2} ms a frame, {:.2} on {threads}", on_gpu * 1e3, cpu * 1e3);
    let why = if gpu { times } else { format!("{} would gain too little: {times}", adapter.name) };
    Verdict { gpu, why }
}

#[cfg(test)]
mod tests {
    use super::*;
    use taffeta::taffeta_gpu::Kind;

    fn adapter(kind: Kind) -> AdapterInfo {
        let word = |text: &str| text.to_owned();
        AdapterInfo { name: word("Some GPU"), kind, api: word("vulkan"), driver: word("1.0") }
    }

    fn work(nodes: u64) -> Work {
        Work { nodes, substeps: 34, threads: 2, precision: Precision::F32 }
    }

    /// A large GPU: 3 µs a sub-step, 64 bytes a node at 3 TB/s.
    fn fast() -> Result<GpuCost, String> {
        Ok(GpuCost { seconds_per_substep: 3e-6, seconds_per_node: 64.0 / 3e12 })
    }

    /// Part of a processor: 20 µs a sub-step, 64 bytes a node at 40 GB/s.
    fn slow() -> Result<GpuCost, String> {
        Ok(GpuCost { seconds_per_substep: 2e-5, seconds_per_node: 64.0 / 40e9 })
    }

    #[test]
    fn no_more_threads_work_than_run_at_once() {
        let cores = cores();
        assert_eq!(
            (at_once(None), at_once(Some(1)), at_once(Some(1024))),
            (None, Some(1), Some(cores.min(1024)))
        );
        assert_eq!((too_many(None), too_many(Some(1))), (None, None));
        let said = too_many(Some(u16::MAX)).unwrap();
        assert!(said.contains(&format!("65535: this machine runs {cores} at once")), "{said}");
    }

    fn unused() -> Result<GpuCost, String> {
        panic!("nothing is to be measured")
    }

    #[test]
    fn times_of_a_frame_are_sums_over_its_sub_steps() {
        // 34 · 160² / (2 · 280e6), and 2e-4 + 25600 · 6.4e-9 + 34 (3e-6 + 25600 · 64 / 3e12).
        assert!((work(25_600).on_cpu() - 1.554_286e-3).abs() < 1e-9);
        assert!((work(25_600).on_gpu(&fast().unwrap()) - 4.844_08e-4).abs() < 1e-9);
    }

    #[test]
    fn a_large_scene_takes_the_gpu_and_a_small_one_the_cpu() {
        let discrete = adapter(Kind::Discrete);
        for (nodes, gpu) in [(25_600, true), (1_000_000, true), (12_000, false)] {
            let verdict = choose(&work(nodes), &discrete, fast);
            assert_eq!(verdict.gpu, gpu, "{nodes} nodes: {verdict:?}");
        }
        assert_eq!(
            choose(&work(25_600), &discrete, fast).why,
            "about 0.48 ms a frame, 1.55 on 2 CPU threads"
        );
        let verdict = choose(&work(1000), &discrete, unused);
        assert!(!verdict.gpu);
        assert_eq!(verdict.why, "the scene is too small to gain by a GPU");
    }

    #[test]
    fn a_gpu_that_is_hardly_faster_is_not_taken() {
        let verdict = choose(&work(1_000_000), &adapter(Kind::Integrated), slow);
        assert!(!verdict.gpu);
        let why = "Some GPU would gain too little: about 61.68 ms a frame, 60.71 on 2 CPU threads";
        assert_eq!(verdict.why, why);
        let one = Work { threads: 1, ..work(1_000_000) };
        assert!(!choose(&one, &adapter(Kind::Integrated), slow).gpu, "1.97 times as fast is not twice");
    }

    #[test]
    fn many_threads_and_few_sub_steps_speak_for_the_cpu() {
        let discrete = adapter(Kind::Discrete);
        assert!(choose(&Work { threads: 4, ..work(65_536) }, &discrete, fast).gpu);
        assert!(!choose(&Work { threads: 64, ..work(65_536) }, &discrete, fast).gpu);
        assert!(!choose(&Work { substeps: 1, ..work(65_536) }, &discrete, fast).gpu);
    }

    #[test]
    fn software_f64_and_failures_mean_the_cpu() {
        let verdict = choose(&work(1_000_000), &adapter(Kind::Software), unused);
        assert!(!verdict.gpu);
        assert_eq!(verdict.why, "only a software adapter (Some GPU) is there");
        let exact = Work { precision: Precision::F64, ..work(1_000_000) };
        assert_eq!(choose(&exact, &adapter(Kind::Discrete), unused).why, "a GPU computes in f32");
        let verdict =
            choose(&work(1_000_000), &adapter(Kind::Discrete), || Err("the GPU was lost".to_owned()));
        assert!(!verdict.gpu);
        assert_eq!(verdict.why, "Some GPU (vulkan, discrete) failed: the GPU was lost");
    }
}
