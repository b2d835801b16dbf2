"""A CasADi function called in place: arguments and result are arrays that it reads and writes without conversion."""

import casadi as ca
import numpy as np
from numpy.typing import NDArray


class BufferedFunction:
    """A function of dense arguments with one dense result, bound to arrays that the caller may change between calls.

    `arguments`: one array (float64, contiguous) an argument; `result`: flat, by columns, overwritten by each call.
    """

    def __init__(self, function: ca.Function, *arguments: NDArray[np.float64]) -> None:
        self.arguments = arguments
        self.result = np.zeros(function.numel_out(0))
        self._buffer, self._call = function.buffer()
        for index, array in enumerate(arguments):
            self._buffer.set_arg(index, array.data)
        self._buffer.set_res(0, self.result.data)

    def __call__(self) -> NDArray[np.float64]:
        """Evaluate; the returned array is the same at every call."""
        self._call()
        return self.result
