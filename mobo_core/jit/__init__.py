"""The ground under all compiled functions: how they are kept, and arithmetic with the same bits everywhere."""
