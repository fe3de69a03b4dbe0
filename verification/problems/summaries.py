"""What each family of problems is, in one sentence."""

SUMMARIES = {
    "random": "Nothing special; n > d may occur.",
    "recognition": (
        "As the paper's data: non-negative, each modality of a row of unit length, o a noisy mix of rows."
    ),
    "zero_row": "One of several robots saw nothing.",
    "zero_modality": "One of several modalities is 0 for every robot.",
    "zero_data": "X = 0.",
    "duplicate_rows": "Two robots saw the same.",
    "near_duplicate_rows": "Two robots saw the same up to 2^-20 .. 2^-53 of each entry.",
    "rank_deficient": (
        "Half of the rows are exact integer combinations of the others; entries are multiples of 2^-20."
    ),
    "nearly_rank_deficient": (
        "Half of the rows are integer combinations of the others, rounded: full rank by rounding alone."
    ),
    "zero_target": "The target o is 0, so that F* = 0.",
    "target_in_span": (
        "The target is a combination of the rows, so that the loss alone can reach 0 (up to rounding)."
    ),
    "orthogonal_target": "X o = 0, so that w = u = 0 is optimal.",
    "lambda1_zero": "lambda1 = 0, the rank full or not.",
    "lambda2_zero": "lambda2 = 0, the rank full or not.",
    "lambda3_zero": "lambda3 = 0, the rank full or not.",
    "lambda1_lambda2_zero": "lambda1 = 0, lambda2 = 0, the rank full or not.",
    "lambda1_lambda3_zero": "lambda1 = 0, lambda3 = 0, the rank full or not.",
    "lambda2_lambda3_zero": "lambda2 = 0, lambda3 = 0, the rank full or not.",
    "all_lambdas_zero": "lambda1 = 0, lambda2 = 0, lambda3 = 0, the rank full or not.",
    "near_duplicates_without_lambdas": (
        "Near-duplicate rows with at least one lambda 0: least squares is discontinuous here."
    ),
    "lambda_above_critical": "lambda2 at or above 2 max |X o|, where w = 0 begins to be optimal.",
    "one_view": "A single robot, n = 1.",
    "more_views_than_features": "More robots than features, n > d.",
    "one_column_modalities": "As many modalities as columns: the modality norm is the l1-norm.",
    "subnormal_entries": "Some entries of X and o are the smallest subnormal number.",
    "scaled_rows": "Each row by its own power of ten, 1e-6 .. 1e6.",
    "scaled_target": "o, lambda2 and lambda3 together by 1e-8 .. 1e8.",
    "scaled_views": "X by 1e-8 .. 1e8, the lambdas with it, so that F* stays.",
    "scaled_data": "o and X each by their own 1e-8 .. 1e8, the lambdas left alone.",
    "extreme_target": "o, lambda2 and lambda3 together by 1e-150 .. 1e150.",
    "extreme_views": "X by 1e-150 .. 1e150, the lambdas with it, so that F* stays.",
    "extreme_data": "o and X each by their own 1e-150 .. 1e150, the lambdas left alone.",
    "mixed_scales": "Entries of one X from 5e-324 to 1e150, and lambdas from 1e-150 to 1e150.",
    "nearly_zero_view": "Up to two robots saw 1e-8 .. 1e-300 of what the others saw; n > d and lambda3 = 0.",
}
