"""Physics that a model lacks: named from residuals, fitted when allowed, judged by held-out records."""
