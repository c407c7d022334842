//! The kernel from outside: what must hold on any body, in every scheme and number type.

mod bench;
mod blade;
mod corpus;
mod current;
mod cut_surface;
mod cutting;
mod energy;
mod float_environment;
mod held_back;
mod hostile_images;
mod inside;
mod limits;
mod model_image;
mod never_through;
mod numbers;
mod one_sweep;
mod plane;
mod properties;
mod same_bits;
mod slender;
mod snapshot;
mod stress;
mod surface;
mod surface_links;
mod tools;
