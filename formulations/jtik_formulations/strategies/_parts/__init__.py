"""What several strategies share: levels, saturation, task scaling, and the step of mink."""
