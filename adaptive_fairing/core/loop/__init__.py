"""The Loop basis on one triangle: box splines, subdivision, quadrature, patch classes."""
