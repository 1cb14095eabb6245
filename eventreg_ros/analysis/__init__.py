"""What happened: events, rejection, bags, reports, plots."""
