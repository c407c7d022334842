//! The kernel from outside: what must hold on any body, in every scheme and number type.

mod anytime;
mod contact_energy;
mod contact_hostile;
mod corpus;
mod current;
mod energy;
mod float_environment;
mod hard_states;
mod hostile_images;
mod inside;
mod invariants;
mod limits;
mod model_image;
mod never_through;
mod numbers;
mod one_sweep;
mod plane;
mod same_bits;
mod slender;
mod snapshot;
mod surface;
mod surface_links;
mod tools;
