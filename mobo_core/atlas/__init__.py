"""What every joint order can do: the front of each, from the bags of studies, and what a study is short of it."""
