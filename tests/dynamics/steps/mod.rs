//! Steps in time: their order, length, error and memory, and what drives them.

mod adaptive;
mod allocation;
mod driven;
mod order;
mod radau;
mod resolution;
