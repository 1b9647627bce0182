//! The path tracer and the irradiance cache against closed forms.

mod closed_forms;
mod gradients;
mod promises;
mod scenes;
