"""Where the papers are misprinted or wrong, and what is right."""

# paper, place, what it says, what is right
MISPRINTS = [
    ("Huang 2011", "Section 4.1, eq. 15",
     "the Laplacian of eq. 6 is used",
     "eq. 15 and every table are eq. 7, with the discrete lambda = sum w r^2 / sum w"),
    ("Huang 2011", "Table 1, center",
     "1.811e-8, 1.571e-9, 2.681e-10, 6.674e-11",
     "1.813e-8, 1.582e-9, 2.736e-10, 7.016e-11: the kernel's constants were in single precision"),
    ("Huang 2011", "Table 1, rates 7.27, 7.04, 6.93",
     "faster than the theoretical fourth order, \"due possibly to machine error\"",
     "sixth order, which the nine-point stencil has on harmonic functions: the rates took "
     "ln(7/5), ... for spacings of 1/4, 1/6, ..."),
    ("Huang 2011", "Table 2, center, 10 cells", "3.890e-14",
     "1.53e-13, the truncation error of eqs. 5 and 7 alone"),
    ("Huang 2011", "Tables 2 and 3, last digits",
     "4.352e-4 (rational, 20 cells); 7.828e-3, 6.263e-3 (center) and 5.788e-3 (upwind)",
     "4.3527e-4; 7.8273e-3, 6.2625e-3 and 5.7874e-3"),
    ("Huang 2011", "Tables 3 to 5, upwind", "eqs. 23-28 were run",
     "W_j = w_j - (16/5) (h/L) (|u|/U) beta(s gamma) c |c| / |w'(1/2)| with L = U = 1, "
     "gamma = |u| h/(2 mu), s = 1/sqrt 2 in Table 3 and 4 in Tables 4 and 5 (upwind `published`): "
     "a length is built in, so it is kept for reproduction only"),
    ("Huang 2011", "eqs. 29-32", "m, and so the damping, goes with dx^2",
     "a diffusivity |u| m needs dx: damping by eqs. 23-28 (upwind `exact`) is of first order in dx. "
     "The second power is that of what was run"),
    ("Huang 2011", "Figure 3, caption", "Pe = 1e-3", "Pe = 1e-5, as in the text"),
    ("Huang 2011", "Section 5.3", "lambda = pi^2 + 1/(4 mu^2)",
     "lambda = sqrt(pi^2 + 1/(4 mu^2))"),
    ("Huang 2011", "Section 5.2", "\"no oscillatory solution is found\"",
     "over- and undershoots of up to 2 per cent (Figure 8 below)"),
    ("Hwang 2016", "eqs. 7, 17a", "phi_2", "Phi_2"),
    ("Hwang 2016", "eq. 17a, second", "(17a)", "(17b)"),
    ("Hwang 2016", "eqs. 22b, 23", "tau_xy, not said of which operator",
     "the entry of the symmetric tensor, half of the coefficient of phi_xy in eq. 21: the operator "
     "is tau_xx phi_xx + 2 tau_xy phi_xy + tau_yy phi_yy"),
    ("Hwang 2016", "eq. 33b", "a series in alpha", "exact for every alpha and phi*"),
    ("Hwang 2016", "Section 4.1, effective diffusivity", "\"derived from eq. 24\"", "from eq. 30b"),
    ("Hwang 2016", "Section 4.1, Figure 4", "\"less than 4 % ... (alpha <= 0.5)\"",
     "mean 10.6 %, root mean square 15.5 % at alpha = 0.5; 4.2 % in the mean at 0.3"),
    ("Hwang 2016", "eqs. 39d, 44c, 48c", "dt = C_D Omega_0 / (2 d Omega_2)",
     "the minimum of that over the points"),
    ("Hwang 2016", "eqs. 42, 46", "u_N / n_C", "the root mean square of u_N, over n_C"),
    ("Hwang 2016", "Sections 4.2, 4.3", "the shear part of the diffusivity dominates",
     "it exceeds the mean of 1 - tau_xx; point by point the two are equal"),
    ("Hwang 2016", "Section 4.3", "Re_mu", "Re_u"),
]
