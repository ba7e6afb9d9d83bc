//! Hard-particle Monte Carlo with screened charges and geometric cluster moves.
