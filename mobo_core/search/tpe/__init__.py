"""Tree-structured Parzen estimator for two objectives, at the speed that thousands of trials ask for."""
