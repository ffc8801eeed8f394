//! Which way of solving springs is the fastest to a wanted error, on three scenes.
