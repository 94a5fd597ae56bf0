"""What leads on from where an update law rests without having arrived: saddle points, levels out of reach."""
