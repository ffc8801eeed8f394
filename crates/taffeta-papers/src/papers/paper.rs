//! The papers.

/// One of the three papers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Paper {
    /// Va, Choi, Hong 2021: cloth by compute shaders.
    S1,
    /// "CUDA Cloth Simulation": cloth that touches itself.
    S2,
    /// Va, Choi, Hong 2023: bodies that keep their volume.
    S3,
}

impl Paper {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::S1, Self::S2, Self::S3];

    /// By which it is named here.
    pub fn name(self) -> &'static str {
        match self {
            Self::S1 => "S1",
            Self::S2 => "S2",
            Self::S3 => "S3",
        }
    }

    /// In full.
    pub fn citation(self) -> &'static str {
        match self {
            Self::S1 => {
                "Hongly Va, Min-Hyung Choi, Min Hong, \"Real-Time Cloth Simulation Using Compute Shader in Unity3D for AR/VR \
                 Contents\", Applied Sciences 11 (17), 8255, 2021, <https://doi.org/10.3390/app11178255>"
            }
            Self::S2 => {
                "\"CUDA Cloth Simulation\", a project report on the web (repository `CUDA-Cloth-Simulation`)"
            }
            Self::S3 => {
                "Hongly Va, Min-Hyung Choi, Min Hong, \"Real-Time Surface-Based Volume Constraints on Mass-Spring Model in \
                 Unity3D\", IEEE Access 11, 2023"
            }
        }
    }
}
