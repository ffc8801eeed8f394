//! What is wrong in the papers, each with a small experiment that shows it.
