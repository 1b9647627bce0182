//! The path tracer and the irradiance cache against closed forms.

mod closed_forms;
mod peers;
mod scenes;
