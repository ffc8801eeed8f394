"""Fitting: what a fabric must be so that simulations look like what was measured.

``taffeta.fit`` searches with CMA-ES (Hansen and Ostermeier, 2001), ends with Gauss-Newton steps, and says how well each parameter
is known.
"""

from taffeta.fitting._fit import fit
from taffeta.fitting._model import Parameter, Target
from taffeta.fitting._result import Estimate, Fit

__all__ = ["Estimate", "Fit", "Parameter", "Target", "fit"]
