/// A fact that a log does not show and its user knows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Question {
    /// The option that answers it.
    pub flag: &'static str,
    /// The unknown fact, and the allowed answers.
    pub text: String,
}
