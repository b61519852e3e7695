"""What a plant or a solution does over the domain: margins of the LMIs, poles and norms, grids that cover it."""
