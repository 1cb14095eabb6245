"""How much it tolerates: evaluator, margins."""
