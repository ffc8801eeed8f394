//! S1: cloth by springs, by implicit constraints (ICE), and by springs that become constraints (ACAD).

mod costs;
mod counts;
mod figures;
mod others;
pub mod sheets;
mod springs;

use crate::report::look::Look;
use crate::report::page::Section;
use crate::runs::job::Job;

/// All runs.
pub fn jobs() -> Vec<Job> {
    [counts::jobs(), sheets::jobs(), others::jobs(), costs::jobs(), figures::jobs()].concat()
}

/// What came out.
pub fn sections(look: &Look) -> Vec<Section> {
    let mut sections =
        vec![counts::section(look), sheets::section(look), others::section(look), costs::section(look)];
    sections.extend(figures::sections(look));
    sections
}
