"""What a solution does over the domain: by how much the LMIs hold, and poles and norms at frozen parameters."""
