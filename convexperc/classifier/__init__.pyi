from .estimator import MultiViewClassifier, UnprovedLabelWarning

__all__ = [
    "MultiViewClassifier",
    "UnprovedLabelWarning",
]
