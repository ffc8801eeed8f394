//! Simulations that work on threads of the program.

use taffeta::rayon::{self, ThreadPoolBuilder};
use taffeta::scene::{Body, Mass, Mesh, Scene, Select};
use taffeta::{Options, Pool, Simulation};

fn scene() -> Scene {
    let cloth = Body::cloth("cloth", Mesh::grid(40, 40, [1.0, 1.0])).with_mass(Mass::Node(1e-3));
    Scene::new("hangs")
        .time(0.01, 1e-3)
        .body(cloth.structural(20.0, 0.01).collide(0.01).pin(Select::nodes([0, 39])))
}

fn on(pool: Option<&Pool>, threads: usize) -> Simulation {
    let options = Options { threads: Some(threads), pool: pool.cloned(), ..Options::default() };
    Simulation::new(&scene(), &options).unwrap()
}

fn ran(mut simulation: Simulation) -> u64 {
    simulation.advance(8).unwrap();
    simulation.state_hash()
}

#[test]
fn simulations_share_threads_of_the_program_wherever_they_are_stepped() {
    let wanted = ran(on(None, 1));
    let threads = std::sync::Arc::new(ThreadPoolBuilder::new().num_threads(3).build().unwrap());
    let pool = Pool::from(std::sync::Arc::clone(&threads));
    assert_eq!((pool.threads(), on(Some(&pool), 9).threads()), (3, 3));
    // One after the other, and at once from threads that are not of the pool.
    assert_eq!([ran(on(Some(&pool), 3)), ran(on(Some(&pool), 2))], [wanted; 2]);
    let outside: Vec<_> = (1..=3)
        .map(|workers| {
            let simulation = on(Some(&pool), workers);
            std::thread::spawn(move || ran(simulation))
        })
        .collect();
    outside.into_iter().for_each(|one| assert_eq!(one.join().unwrap(), wanted));
    // At once on all threads of the pool, where each would wait for the others.
    let inside = [on(Some(&pool), 3), on(Some(&pool), 3), on(Some(&pool), 2)];
    let hashes = threads.install(|| {
        use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};
        inside.into_par_iter().map(ran).collect::<Vec<_>>()
    });
    assert_eq!(hashes, [wanted; 3]);
    // On threads of another pool, which take up other work where they wait.
    let other = ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    let rooms: Vec<Simulation> = (0..24).map(|_| on(Some(&pool), 3)).collect();
    let hashes = other.install(|| {
        use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};
        rooms.into_par_iter().map(ran).collect::<Vec<_>>()
    });
    assert_eq!(hashes, [wanted; 24]);
    // Built there, too.
    assert_eq!(threads.install(|| ran(on(Some(&pool), 3))), wanted);
}
