"""Stage 4, relax: a parametric LMI becomes finitely many LMIs, labelled and with their soundness."""
