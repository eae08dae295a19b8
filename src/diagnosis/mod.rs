//! From residuals to causes: what the model gets wrong, and why.
