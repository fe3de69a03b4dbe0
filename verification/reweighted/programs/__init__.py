"""Programs as black boxes, judged against the certified optimum of each input."""
