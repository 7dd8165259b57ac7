"""Pictures of machines, architectures and counterexamples, drawn without any program beside Python."""
