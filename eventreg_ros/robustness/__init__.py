# SPDX-License-Identifier: Apache-2.0
"""How much it tolerates: evaluator, margins."""
